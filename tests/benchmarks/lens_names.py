"""How many of the lenses that exiftool names, and LensFun holds, are found by that name.

    python -m tests.benchmarks.lens_names

Names come from exiftool's own tables; LensFun holds a lens where its name has the same words and
numbers, makers' names apart. The rule for that is written here independently.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from plumbline.errors import PlumblineError
from plumbline.lenses.lensfun.database import common_database
from plumbline.lenses.lookup import look_up
from plumbline.lenses.request import LensRequest
from plumbline.observations.facts import LensFacts
from plumbline.photos.exif import PhotoFacts

CAMERAS = {
    "Canon": (("Canon", "Canon EOS 5D Mark III"), ("Canon", "Canon EOS 7D")),
    "Nikon": (("NIKON CORPORATION", "NIKON D800"), ("NIKON CORPORATION", "NIKON D90")),
    "Pentax": (("PENTAX Corporation", "PENTAX K10D"),),
    "Sony": (("SONY", "SLT-A99V"), ("SONY", "SLT-A77V")),
    "Olympus": (("OLYMPUS IMAGING CORP.", "E-M5"),),
}
MAKERS = ("canon", "nikon", "sony", "pentax", "olympus", "minolta", "lens", "mm", "f")


@dataclass(frozen=True)
class Found:
    """One lens: exiftool's name, LensFun's, and what was found."""

    told: str
    held: str
    used: str

    @property
    def right(self) -> bool:
        return words(self.held) <= words(self.used)


def words(name: str) -> set[str]:
    parts = re.findall(r"[a-z]+|\d+(?:\.\d+)?", name.lower().replace("f/", " "))
    return {part for part in parts if part not in MAKERS}


def names(program: str, maker: str) -> set[str]:
    """All names of lenses in exiftool's tables of a maker."""
    listing = subprocess.run(
        [program, "-listx", f"-{maker}:all"], capture_output=True, check=True
    ).stdout
    tags = etree.fromstring(listing).iter("tag")
    wanted = ("LensType", "LensID", "LensIDNumber")
    return {
        value.text or "" for tag in tags if tag.get("name") in wanted for value in tag.iter("val")
    }


def found(program: str, makers: dict[str, Any] = CAMERAS) -> Iterator[Found]:
    """Each lens that both know, looked up for a photo at its shortest focal length."""
    library = common_database().library
    for maker, cameras in makers.items():
        every = {frozenset(words(name)): name for name in sorted(names(program, maker))}
        done: set[str] = set()
        for make, model in cameras:
            for lens in library.find_lenses(library.find_cameras(make, model)[0]):
                told = every.get(frozenset(words(lens.model)))
                if not told or lens.model in done or not lens.calib_distortion:
                    continue
                done.add(lens.model)
                focal = min(each.focal for each in lens.calib_distortion)
                facts = LensFacts(camera=f"{make} {model}", model=told, focal_mm=focal)
                photo = PhotoFacts((600, 400), facts, maker=make, model=model)
                try:
                    used = look_up(photo, LensRequest()).profile.description
                except PlumblineError as error:
                    used = error.message
                yield Found(told, lens.model, used.partition(" on ")[0])


if __name__ == "__main__":
    results = list(found("exiftool"))
    wrong = [each for each in results if not each.right]
    print(f"{len(results) - len(wrong)} of {len(results)} lenses found by exiftool's name")
    for each in wrong:
        print(f"  {each.told}: {each.used}")
