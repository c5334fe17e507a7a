"""The charts of studies, as SVG."""
