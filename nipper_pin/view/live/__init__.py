"""A page with sliders whose numbers, plots and picture follow them.

Stage, page and server need the extra ``live`` (viser); no other command imports anything of this.
"""
