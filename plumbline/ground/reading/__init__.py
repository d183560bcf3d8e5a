"""Match points, tapes and lines of a photographed plane, from files."""
