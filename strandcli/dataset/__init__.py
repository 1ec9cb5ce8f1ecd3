"""Data sets for training: many views of strands, each a picture with labels, as other programs read them.

`views` says where cameras stand and what light and colour there is, `studio` draws, a layout of `layouts` makes files
of the labels of what is drawn, and `run` goes from one to the next and can be taken up again.
"""
