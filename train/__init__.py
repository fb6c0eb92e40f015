"""Training policies with Stable-Baselines3, and what they come to beside open-loop schedules.

Nothing is imported here: torch takes seconds, and `stickslip.train.schedules` does without it.
"""
