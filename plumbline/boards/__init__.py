"""Chequerboards in photographs: their corners, labelled by column and row."""
