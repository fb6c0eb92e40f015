"""Pictures of a crawler: from what is so at one instant to shapes and words, and from these to pixels and films."""
