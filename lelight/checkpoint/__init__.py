"""What a run has found so far, kept in a folder, so that it can go on after it was stopped, killed or cut off.

Every piece of work depends on scene, settings and seed only, so a piece that is read back is as good as one that is
done again: a resumed run gives the same bits. Nothing here is ever executed: numbers, names and text.
"""
