"""What is left alone: texts that explain, looks, and keywords that only say what is so already."""

from __future__ import annotations

PROSE = {"message", "help", "metavar", "description", "epilog", "prog", "reason", "hint", "title"}
LOOKS = {
    "alpha", "bbox_to_anchor", "borderpad", "box", "capsize", "clip_on", "color", "colour", "dpi",
    "edgecolor", "edgewidth", "exist_ok", "facecolor", "figsize", "fill", "fontsize", "fontweight",
    "frameon", "ha", "handlelength", "hatch", "height_ratios", "highlight", "indent", "justify",
    "labelpad", "layout", "linestyle", "linewidth", "linewidths", "loc", "lw", "marker",
    "markeredgecolor", "markeredgewidth", "markerfacecolor", "markersize", "mutation_scale",
    "ncols", "no_wrap", "opacity", "overflow", "pad", "pad_edge", "padding", "parents",
    "rasterized", "rotation", "s", "shininess", "show_edge", "size", "soft_wrap", "stroke",
    "style", "textcoords", "title_justify", "va", "vertical", "visible", "which", "width_ratios",
    "wrap", "xytext", "zorder",
}  # fmt: skip
IDLE = {"strict", "encoding", "default_factory", "slots", "frozen", "kw_only", "allow_nan"}
SILENT_CALLS = (
    "warn", "debug", "info", "TypeVar", "cast", "grid", "Figure", "FigureCanvasAgg", "margins",
    "tick_params", "subplots_adjust", "GridSpec", "align_ylabels", "MaxNLocator", "set_axisbelow",
    "inset_axes", "new_figure",
)  # fmt: skip
