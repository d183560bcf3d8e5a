"""A photographed plane: camera, ground points, tapes and lines adjusted together, to scale."""
