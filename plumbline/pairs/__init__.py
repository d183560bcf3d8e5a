"""Two pictures of one scene, one of them corrected: the lens between them."""
