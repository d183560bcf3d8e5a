"""A board shown on a screen and photographed there: moiré."""

from __future__ import annotations

import cv2
import numpy as np


def monitor(pitch_px: float, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """A board on a screen whose pixels the camera nearly resolves, and its true corners."""
    squares, steps = 2 * round(20 / pitch_px), (np.arange(4) + 0.5) / 4 - 0.5
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) / pitch_px
    pixels = np.stack(np.meshgrid(np.arange(600), np.arange(440)), -1) - np.array([300.0, 220.0])
    light = np.zeros(pixels.shape[:2])
    for step in np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2):
        on_screen = (pixels + step) @ turned
        which = np.floor(on_screen)
        lit = (np.abs(on_screen - which - 0.55) < 0.35).all(axis=-1)
        column, row = np.moveaxis(np.floor(which / squares), -1, 0)
        dark = (np.abs(column + 0.5) < 6) & (np.abs(row + 0.5) < 4) & ((column + row) % 2 == 0)
        light += np.where(lit & ~dark, 0.9, 0.02) / 16
    grey = 255 * cv2.GaussianBlur(light, (0, 0), 0.3) ** (1 / 2.2)
    cells = np.stack(np.meshgrid(np.arange(-5, 6), np.arange(-3, 4)), -1).reshape(-1, 2)
    corners = cells * squares @ np.linalg.inv(turned) + np.array([300.0, 220.0])
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8), corners
