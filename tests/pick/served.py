"""A server of `plumbline pick` as a process of its own, and photographs to pick in."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgspec
import numpy as np
from PIL import Image

ROOT = Path(__file__).parents[2]
FACADE = ROOT / "sample_projects" / "facade_csv" / "facade.jpg"


class Served:
    """One running server."""

    def __init__(self, process: subprocess.Popen[str], address: str) -> None:
        self.process = process
        self.address = address
        self.place = urlsplit(address)

    def ask(
        self,
        path: str,
        body: object = None,
        *,
        method: str | None = None,
        secret: str | None = None,
        **headers: str,
    ) -> tuple[int, dict[str, str], bytes]:
        """One request: status, headers, body. Headers given as None are left out."""
        connection = HTTPConnection("127.0.0.1", self.place.port or 0, timeout=60)
        known = secret if secret is not None else self.place.path
        sent: dict[str, str] = {"Host": self.place.netloc}
        content = None
        if body is not None:
            content = body if isinstance(body, bytes) else msgspec.json.encode(body)
            sent |= {"Content-Type": "application/json", "Origin": f"http://{self.place.netloc}"}
        sent |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection.putrequest(
            method or ("GET" if body is None else "POST"),
            known + path,
            skip_host=True,
            skip_accept_encoding=True,
        )
        for name, value in sent.items():
            if value:
                connection.putheader(name, value)
        if content is not None:
            connection.putheader("Content-Length", str(len(content)))
        with contextlib.closing(connection):
            connection.endheaders(content)
            answer = connection.getresponse()
            return answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()

    def act(self, page: str = "test", **action: Any) -> Any:
        """Ask for an action; the answer."""
        status, _, content = self.ask("act", {"page": page, "action": action})
        assert status == 200, content
        return msgspec.json.decode(content)

    def state(self) -> Any:
        """What a page is told when it opens."""
        return msgspec.json.decode(self.ask("state")[2])


@contextmanager
def served(*arguments: str | Path) -> Generator[Served]:
    """Run `plumbline pick --no-browser`, and end it."""
    command = [sys.executable, "-m", "plumbline", "pick", "--no-browser", *map(str, arguments)]
    process = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        first = process.stdout.readline()
        if not first.startswith("Picking at "):
            raise RuntimeError(first + process.communicate(timeout=60)[1])
        yield Served(process, first.split()[-1])
    finally:
        process.terminate()
        try:
            process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def bent_lines(
    size: tuple[int, int], k1: float = 0.02, count: int = 10, points: int = 7
) -> list[list[tuple[float, float]]]:
    """Rows and columns as a lens shows them whose ideal radius is r (1 + k1 r²), noise 0.2 px.

    The inverse is found by bisection, away from plumbline's own models.
    """
    rng = np.random.default_rng(5)
    width, height = size
    centre, half = np.array([(width - 1) / 2, (height - 1) / 2]), min(size) / 2
    found: list[list[tuple[float, float]]] = []
    for index in range(count):
        share = 0.06 + 0.88 * (index // 2) / max(count // 2 - 1, 1)
        along = np.linspace(0.06, 0.94, points)
        across = np.full(points, share)
        pair = (along, across) if index % 2 else (across, along)
        ideal = (np.stack(pair, axis=1) * np.array([width - 1, height - 1]) - centre) / half
        radius = np.hypot(*ideal.T)
        low, high = np.zeros_like(radius), np.full_like(radius, 4.0)
        for _ in range(60):
            middle = (low + high) / 2
            below = middle * (1 + k1 * middle**2) < radius
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        observed = centre + ideal * (low / np.maximum(radius, 1e-12))[:, None] * half
        observed += rng.normal(0, 0.2, observed.shape)
        found.append([(float(x), float(y)) for x, y in observed])
    return found


def photo_file(path: Path, size: tuple[int, int] = (600, 400), **how: Any) -> Path:
    """A photograph of a soft chequerboard."""
    y, x = np.mgrid[: size[1], : size[0]]
    values = 127 + 80 * np.sign(np.sin(x / 17) * np.sin(y / 13))
    Image.fromarray(np.repeat(values[..., None], 3, axis=2).astype(np.uint8)).save(path, **how)
    return path


def plain(lines: Sequence[Any]) -> list[Any]:
    """Lines of an answer without what may differ."""
    return [{k: v for k, v in line.items() if k != "errors"} for line in lines]
