"""What an adjustment is worth: disorder, gaps, contradictions, the implied camera, advice."""
