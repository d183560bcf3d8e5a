"""Projects of Hugin, PTGui and the Panorama Tools."""
