"""The picture of a rectified plane: a grid on the ground, its pixels, and its georeference."""
