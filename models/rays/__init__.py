"""Our own ray caster, where embree has no wheel."""
