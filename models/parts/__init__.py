"""Built-in parts, each a few lines of CSG: `names`, `build` and what `palpate parts` lists."""

from models.parts.catalog import BuiltIn, build, describe, names, unknown

__all__ = ["BuiltIn", "build", "describe", "names", "unknown"]
