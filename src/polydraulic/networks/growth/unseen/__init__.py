"""What networks do on rows that they have not seen: which of them to keep, and whether there is anything to learn.

`choice` keeps a layer, by rows or blocks of rows left out; `chance` and `evidence` ask whether a search so wide would have found as much
in a target that has nothing to do with the inputs.
"""
