"""Rows as a Parquet table: columns and types from the suite alone, so that the tables of shards can be joined."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from recognition.experiments.suite import Suite
from recognition.experiments.trial import Row

_TYPES = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}


def write_table(path: Path, suite: Suite, rows: Sequence[Row]) -> None:
    """One row a trial; a setting that a trial does not have is null."""
    columns = suite.columns
    schema = pa.schema([(name, _TYPES[kind]) for name, kind in columns.items()])
    table = pa.table(
        {name: pa.array([row.get(name) for row in rows], _TYPES[kind]) for name, kind in columns.items()},
        schema,
    )
    pq.write_table(table, path)
