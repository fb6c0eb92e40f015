"""The page of ``stickslip explore``: plots by Bokeh, whose server keeps a session for each visitor."""
