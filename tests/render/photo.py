"""Takes the photograph: rays through the lens, blur, sensor noise, JPEG and EXIF."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from .optics import Array, View
from .scene import Canvas, Picture, clouds

SOFTWARE = "plumbline sample renderer"
QUALITY = 85
SUPERSAMPLE = 2
STRIP = 64  # rows of the photo rendered at a time
BLUR_PX = 0.55
EXPOSURE_S = 1 / 250
APERTURE = 8.0
NOISE = 1.6  # standard deviation, grey levels

Layer = NDArray[np.float32]


def take(view: View, canvas: Canvas, seed: int) -> Picture:
    """Return the photograph as sRGB, shape (height, width, 3)."""
    rng = np.random.default_rng(seed)
    heaven = clouds((256, 1024), rng, cells=3).astype(np.float32)
    asphalt = clouds((512, 512), rng, cells=16).astype(np.float32)
    strips = [
        _strip(view, canvas, heaven, asphalt, top, min(top + STRIP, view.height))
        for top in range(0, view.height, STRIP)
    ]
    picture = np.concatenate(strips)
    y, x = np.mgrid[: view.height, : view.width]
    far = np.hypot(x - view.centre[0], y - view.centre[1]) / np.hypot(*view.centre)
    picture = cv2.GaussianBlur(picture * (1 - 0.16 * far**2)[..., None], (0, 0), BLUR_PX)
    grain = cv2.GaussianBlur(rng.standard_normal(picture.shape), (0, 0), 0.6)
    noisy = picture + NOISE * grain / grain.std() * np.sqrt(np.maximum(picture, 20) / 110)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def _strip(
    view: View, canvas: Canvas, heaven: Layer, asphalt: Layer, top: int, end: int
) -> NDArray[np.float64]:
    """Render some rows: several rays a pixel, averaged."""
    n = SUPERSAMPLE
    sub = (np.arange(n) + 0.5) / n - 0.5
    xs = (np.arange(view.width)[:, None] + sub).ravel()
    ys = (np.arange(top, end)[:, None] + sub).ravel()
    rays = view.rays(np.stack(np.meshgrid(xs, ys), axis=-1))
    colours = _look(view, canvas, heaven, asphalt, rays)
    return colours.reshape(end - top, n, view.width, n, 3).mean(axis=(1, 3))


def _look(
    view: View, canvas: Canvas, heaven: Layer, asphalt: Layer, rays: Array
) -> NDArray[np.float64]:
    """Return the colour that each ray meets: wall, else sky above and street below."""
    pose = view.pose
    ahead = np.maximum(rays[..., 2], 1e-6)
    x = pose.x + pose.distance * rays[..., 0] / ahead
    y = pose.eye - pose.distance * rays[..., 1] / ahead
    u, v = canvas.to_texels(x, y)
    wall = cv2.remap(canvas.rgb, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    solid = cv2.remap(canvas.solid, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    cover = (solid / 255.0)[..., None]
    seen = wall + _sky(rays, heaven) * (1 - cover)
    return np.where((y < 0)[..., None], _street(view, rays, asphalt), seen)


def _sky(rays: Array, heaven: Layer) -> Array:
    """A pale summer sky, bluer overhead, with thin clouds."""
    length = np.linalg.norm(rays, axis=-1)
    up = np.clip(-rays[..., 1] / length, 0, 1)
    turn = np.arctan2(rays[..., 0], rays[..., 2])
    u = ((turn / np.pi + 0.5) * 1020).astype(np.float32)
    v = ((1 - up) * 255).astype(np.float32)
    cloud = cv2.remap(heaven, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    white = np.clip(0.32 + 0.28 * cloud - 0.2 * up, 0, 0.85)[..., None]
    blue = np.array([158.0, 192.0, 226.0]) - up[..., None] * np.array([74.0, 58.0, 30.0])
    return blue * (1 - white) + np.array([236.0, 238.0, 240.0]) * white


def _street(view: View, rays: Array, asphalt: Layer) -> Array:
    """A pavement along the wall, its kerb, then asphalt."""
    pose = view.pose
    reach = pose.eye / np.maximum(rays[..., 1], 1e-6)
    x = pose.x + reach * rays[..., 0]
    near = np.clip(pose.distance - reach * rays[..., 2], 0, 200)  # metres from the wall's foot
    u, v = (x * 24 % 511).astype(np.float32), (near * 24 % 511).astype(np.float32)
    grain = cv2.remap(asphalt, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    joint = ((x % 0.8 < 0.03) | (near % 0.8 < 0.03)).astype(float)
    pavement = 158 - 26 * joint + 4 * grain
    grey = np.where(near < 3.0, pavement, np.where(near < 3.2, 188, 96 + 6 * grain))
    grey = np.where((near > 5.9) & (near < 6.05), 206, grey)
    return grey[..., None] * np.array([1.0, 0.99, 0.97])


def save(picture: Picture, view: View, path: Path, taken: str) -> None:
    """Write the JPEG with the EXIF that the camera would have written."""
    lens = view.lens
    exif = Image.Exif()
    exif[0x010F] = lens.make
    exif[0x0110] = lens.camera
    exif[0x0112] = 1
    exif[0x0131] = SOFTWARE
    exif[0x0132] = taken
    detail = exif.get_ifd(0x8769)
    detail[0x829A] = EXPOSURE_S
    detail[0x829D] = APERTURE
    detail[0x8827] = 100
    detail[0x9003] = taken
    detail[0x920A] = lens.focal
    detail[0xA002] = view.width
    detail[0xA003] = view.height
    detail[0xA405] = round(lens.focal * lens.crop)
    detail[0xA434] = lens.lens
    Image.fromarray(picture).save(path, quality=QUALITY, subsampling="4:2:0", exif=exif)
