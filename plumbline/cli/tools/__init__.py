"""What the verbs do once their options are parsed."""
