"""What was picked: photographs, the lenses that took them, and points grouped by line.

Nothing here knows a file format or a model. Formats make `Observations`, the fit consumes
them, and the result embeds them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plumbline.errors import DegenerateLinesError, OptionError, ReadError
from plumbline.frame import Array
from plumbline.observations.arrays import lines_from_arrays, lines_from_grid, photo_and_lens
from plumbline.observations.copies import counted_once, told
from plumbline.observations.facts import LensFacts
from plumbline.observations.picks import MAX_SIDE, Line, Origin, Photo
from plumbline.observations.soundness import is_sound
from plumbline.wording import count, listed

__all__ = ["MAX_SIDE", "Line", "Observations", "Origin", "Photo"]


@dataclass(frozen=True, eq=False, repr=False)
class Observations:
    """Photos, lenses and lines, checked as far as one file can be.

    Attributes:
        photos: The photographs.
        lines: The lines with at least three distinct points.
        lenses: Facts about the lenses that took the photos.
        notes: What a reader left aside or assumed, in plain sentences.
        origins: The files they were read from; empty for arrays.
    """

    photos: tuple[Photo, ...]
    lines: tuple[Line, ...]
    lenses: tuple[LensFacts, ...] = (LensFacts(),)
    notes: tuple[str, ...] = ()
    origins: tuple[Origin, ...] = ()

    @classmethod
    def from_arrays(
        cls,
        lines: Iterable[ArrayLike],
        size: tuple[int, int],
        *,
        labels: Sequence[object] | None = None,
        focal_px: float | None = None,
        pixel_aspect: float = 1.0,
    ) -> Observations:
        """Observations of one photo from arrays.

        Args:
            lines: One (n, 2) array of pixel coordinates a line, n ≥ 3, or OpenCV's (n, 1, 2);
                masked points are left out, with a note.
            size: Width and height of the photo in pixels.
            labels: Names of the lines, one each; numbers from 1 by default.
            focal_px: Focal length in pixels, for the models that need it.
            pixel_aspect: Width of one pixel over its height.

        Raises:
            OptionError: an array has the wrong shape or holds NaN or infinity, the size is not
                two positive whole numbers, or there are more or fewer labels than lines.

        Example:
            >>> import plumbline
            >>> edge = [[10, 12], [200, 9], [390, 12]]
            >>> plumbline.Observations.from_arrays([edge], size=(400, 300)).n_points
            3
        """
        found, hidden = lines_from_arrays(lines, labels)
        notes = (f"{count(hidden, 'masked point')} left out",) if hidden else ()
        photo, facts = photo_and_lens(size, focal_px, pixel_aspect)
        return cls((photo,), found, (facts,), notes).checked().counted_once()

    @classmethod
    def from_grid(
        cls,
        points: ArrayLike,
        size: tuple[int, int],
        *,
        focal_px: float | None = None,
        pixel_aspect: float = 1.0,
    ) -> Observations:
        """Observations of one photo of a grid, such as the inner corners of a chequerboard.

        Args:
            points: Pixel coordinates, shape (rows, columns, 2); every row and column is a line.
                Points that are NaN or masked are missing.
            size: Width and height of the photo in pixels.
            focal_px: Focal length in pixels, for the models that need it.
            pixel_aspect: Width of one pixel over its height.

        Raises:
            OptionError: the array has another shape or holds infinity, or the size is not two
                positive whole numbers.
            DegenerateLinesError: no row or column has three points.

        Example:
            >>> import numpy, plumbline
            >>> y, x = numpy.mgrid[100:1100:200, 100:1500:200]
            >>> grid = numpy.stack((x, y), axis=-1)
            >>> plumbline.Observations.from_grid(grid, size=(1600, 1200))
            <Observations: 70 points on 12 lines in 1 photo>
        """
        found, missing = lines_from_grid(points)
        notes = (f"{count(missing, 'point')} of the grid missing",) if missing else ()
        photo, facts = photo_and_lens(size, focal_px, pixel_aspect)
        return cls((photo,), found, (facts,), notes).checked().counted_once()

    @classmethod
    def side_by_side(cls, parts: Sequence[Observations]) -> Observations:
        """Several observations as one, every lens kept apart."""
        photos, lines, lenses = list[Photo](), list[Line](), list[LensFacts]()
        for part in parts:
            lines += [replace(line, photo=line.photo + len(photos)) for line in part.lines]
            photos += [replace(photo, lens=photo.lens + len(lenses)) for photo in part.photos]
            lenses += part.lenses
        notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
        origins = tuple(dict.fromkeys(origin for part in parts for origin in part.origins))
        return cls(tuple(photos), tuple(lines), tuple(lenses), notes, origins)

    def __repr__(self) -> str:
        """In one line what they are."""
        photos, lines = count(len(self.photos), "photo"), count(len(self.lines), "line")
        return f"<Observations: {count(self.n_points, 'point')} on {lines} in {photos}>"

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """Number of points of each line, shape (l,)."""
        return np.array([len(line.points_px) for line in self.lines], dtype=np.int64)

    @property
    def n_points(self) -> int:
        """Number of points on all lines."""
        return int(self.sizes.sum())

    @cached_property
    def centred_px(self) -> Array:
        """All points line after line, in square pixels from their photos' centres, (n, 2)."""
        parts: list[Array] = []
        for photo, lines in groupby(self.lines, key=lambda line: line.photo):
            points_px = np.concatenate([line.points_px for line in lines])
            parts.append(self.photos[photo].frame.normalise(points_px, 1.0))
        return np.concatenate(parts)

    def of_lens(self, lens: int) -> Observations:
        """Only the photos and lines taken with lens number `lens` (from 0)."""
        return self._only([i for i, photo in enumerate(self.photos) if photo.lens == lens])

    def of_photo(self, photo: int) -> Observations:
        """Only photo number `photo` (from 0) and its lines."""
        return self._only([photo])

    def _only(self, keep: list[int]) -> Observations:
        photo_number = {old: new for new, old in enumerate(keep)}
        used = sorted({self.photos[old].lens for old in keep})
        lens_number = {old: new for new, old in enumerate(used)}
        photos = [self.photos[old] for old in keep]
        return replace(
            self,
            photos=tuple(replace(p, lens=lens_number[p.lens]) for p in photos),
            lines=tuple(
                replace(line, photo=photo_number[line.photo])
                for line in self.lines
                if line.photo in photo_number
            ),
            lenses=tuple(self.lenses[old] for old in used),
        )

    def squared(self) -> Observations:
        """The same observations in the photo resampled to square pixels.

        Widths are rounded to whole pixels; points keep their place relative to the edges.
        """
        if all(photo.pixel_aspect == 1.0 for photo in self.photos):
            return self
        photos: list[Photo] = []
        for photo in self.photos:
            width, height = photo.frame.square_size
            photos.append(replace(photo, size=(round(width), round(height)), pixel_aspect=1.0))
        lines: list[Line] = []
        for line in self.lines:
            stretch = photos[line.photo].frame.width / self.photos[line.photo].frame.width
            points = (line.points_px + 0.5) * np.array([stretch, 1.0]) - 0.5
            lines.append(replace(line, points_px=points))
        return replace(self, photos=tuple(photos), lines=tuple(lines))

    def checked(self, *, ideal: bool = False, singly: bool = False) -> Observations:
        """The same observations after the checks that need no fit.

        Lines with fewer than three distinct points are set aside with a note; exact
        duplicates of a point on its line are dropped with a note.

        Args:
            ideal: The points are ideal ones, which may lie outside their photos.
            singly: Points count, not lines: short lines and duplicates stay.

        Raises:
            OptionError: a size is missing or absurd, a coordinate is not finite, or a point
                lies outside its photo.
            DegenerateLinesError: no line is left.
        """
        photos = tuple(photo.checked(self.named) for photo in self.photos)
        if not singly and is_sound(self.lines, photos, ideal=ideal):
            return replace(self, photos=photos)
        notes = list(self.notes)
        kept: list[Line] = []
        short: list[str] = []
        duplicates = 0
        for line in self.lines:
            self._check_points(line, ideal=ideal)
            if singly:
                kept.append(line)
                continue
            first = line.first_of_each()
            duplicates += len(line.points_px) - len(first)
            if len(first) < 3:
                short.append(f"{line.label} ({count(len(first), 'point')})")
            elif len(first) == len(line.points_px):
                kept.append(line)
            else:
                rows = None if line.rows is None else line.rows[first]
                kept.append(replace(line, points_px=line.points_px[first], rows=rows))
        if duplicates:
            notes.append(f"{count(duplicates, 'point')} picked twice on one line counted once")
        if short:
            notes.append(
                f"{count(len(short), 'line')} set aside for having fewer than 3 distinct points: "
                + listed(short)
            )
        if not kept:
            raise DegenerateLinesError(
                f"{self.named}no line with at least 3 distinct points"
                + (f" (set aside: {listed(short)})" if short else ""),
                hint="pick at least three points along each straight edge",
            )
        return replace(self, photos=photos, lines=tuple(kept), notes=tuple(notes))

    def counted_once(self) -> Observations:
        """The same observations without lines and picks that stand there twice.

        A copy is not a second measurement. Lines of one photo that share two picks or more lie on
        one edge, and what they share counts once; a single pick that two lines share is where
        they cross, as in a grid. Notes name the copies.
        """
        of_line = [self.photos[line.photo] for line in self.lines]
        frames = [(photo.lens, photo.size, photo.pixel_aspect) for photo in of_line]
        photos = [
            (photo.name or line.photo, *frame)
            for line, photo, frame in zip(self.lines, of_line, frames, strict=True)
        ]
        lines, copies = counted_once(self.lines, photos, frames)
        if not copies:
            return self
        names = [line.label for line in self.lines]
        if len(set(photos)) > 1:
            shots = [p.name or p.source or f"photo {n}" for n, p in enumerate(self.photos)]
            names = [f"{line.label} of {shots[line.photo]}" for line in self.lines]
        return replace(self, lines=lines, notes=(*self.notes, *told(copies, names)))

    @property
    def named(self) -> str:
        """The name of the file they came from with a colon, for messages; else empty."""
        return f"{self.origins[0].path}: " if len(self.origins) == 1 else ""

    def _check_points(self, line: Line, *, ideal: bool) -> None:
        frame = self.photos[line.photo].frame
        points = line.points_px
        # NaN lies in no photo.
        good = np.isfinite(points).all(axis=-1) if ideal else frame.contains(points)
        if np.all(good):
            return
        worst = int(np.argmin(good))
        x, y = line.points_px[worst]
        sentence = f"the point ({x:g}, {y:g}) of line {line.label} " + (
            f"lies outside the {frame.width}x{frame.height} photo"
            if np.isfinite(x) and np.isfinite(y)
            else "is not a finite number"
        )
        hint = "check the photo's size and the point; pixels count from 0 at the top left"
        if len(self.origins) == 1:
            row = None if line.rows is None else int(line.rows[worst])
            raise ReadError(sentence, path=self.origins[0].path, line=row, hint=hint)
        raise OptionError(sentence, hint=hint)
