"""Pages and pictures for people: what was seen, what depends on what, what the arm did.

`show.show_page` and `figure.show_picture` draw one scene, `run_page.run_page` a whole run from the
`record.RunRecord` it left. Everything is drawn from the JSON documents the commands print.
"""
