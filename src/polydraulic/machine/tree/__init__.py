"""Equations of motion for any tree of links, as text that is generated for its layout.

`links` describes a tree, `link_checks` refuses what is none, `shapes` are links without their numbers; `terms` records arithmetic and
`statements` writes it down; `frames` says in which axes each link is calculated, `mass`, `equations` and `points` record the
mechanics; `motion_text` puts the text together, with `solve_text`.
"""
