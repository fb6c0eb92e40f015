"""Pictures of the crawler: a frame of one, tiles of many, and the window that shows them."""
