"""Dense samples of edges that bend by themselves: generalised least squares."""
