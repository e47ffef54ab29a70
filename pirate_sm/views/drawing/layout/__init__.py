"""A layered layout: ranks from top to bottom, few crossings, long edges straight.

The stages are those of Sugiyama, Tagawa and Toda, "Methods for visual understanding of hierarchical
system structures" (1981), with labels as vertices of their own as in Gansner, Koutsofios, North
and Vo, "A technique for drawing directed graphs" (1993).
"""
