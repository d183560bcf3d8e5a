"""What picture files hold beside their pixels, read and written byte for byte."""
