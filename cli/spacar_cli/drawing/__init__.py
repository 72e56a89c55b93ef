"""Pictures of mechanisms: pure functions from result arrays to drawable geometry, then matplotlib.

source -> Scene and coordinates -> shapes (lines, faces, marks) -> paint on a matplotlib figure. Nothing here opens a
window unless `window` or `live` is called, and matplotlib is imported only where it draws.
"""
