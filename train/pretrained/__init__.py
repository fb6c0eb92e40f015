"""Weights and descriptions of the policies that `stickslip.pretrained` reads."""
