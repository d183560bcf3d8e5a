"""The page to pick on: a server on this machine alone, and the page that it serves.

`document` holds what was picked with its history, `saving` keeps it on disk, `photos` and `tiles`
show photographs, `live` fits while one picks, `advice` says where to pick next, `session` puts
these together, and `app` lets the page ask for them, behind `security`.
"""
