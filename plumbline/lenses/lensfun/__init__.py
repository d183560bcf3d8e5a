"""LensFun's database: finding a lens in it and using it."""
