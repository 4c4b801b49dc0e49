"""Equations of motion for any tree of links, as text that is generated for its layout.

`links` describes a tree; `terms` records arithmetic and `statements` writes it down; `frames` says in which axes each link is
calculated, `equations` and `points` record the mechanics; `motion_text` puts the text together, with `solve_text`.
"""
