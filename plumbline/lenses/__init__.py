"""What is known of lenses apart from the fit: EXIF, databases, coefficients over focal length."""
