"""File formats of picked points and lenses: one file each; `known` has those of points."""
