"""PDF reports of a result folder: they read what a run wrote and never trace a ray.

Route of a report: ``folder`` reads OUT → ``summary``, ``sights``, ``surfaces``, ``method`` turn it into
sentences and tables → ``figures`` draws → ``document`` sets the pages with Typst. ``luminance`` and ``glare``
are the two reports; ``rounding`` decides how a number with its error is written.
"""
