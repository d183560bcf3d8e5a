"""Where each pixel of a corrected photograph is taken from."""
