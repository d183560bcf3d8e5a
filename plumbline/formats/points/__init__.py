"""Points exported by viewers and digitizers."""
