"""Table of a study of relative sparsity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.records.wording import short


def sparsity_table(study: Mapping[str, Any]) -> Group:
    """Table of a study of relative sparsity, from its `to_dict`."""
    tables = []
    for key, title in (
        ("against_intervals", "Relative sparsity against intervals"),
        ("against_limit", "Relative sparsity against torque limit"),
    ):
        table = Table(title=Text(title, style="bold"), box=box.SIMPLE_HEAD, title_justify="left")
        for header in ("N", "limit [N m]", "active", "found [%]", "one axis [%]", "bound [%]"):
            table.add_column(Text(header), justify="right")
        for point in study[key]:
            table.add_row(
                str(point["intervals"]),
                short(point["torque_limit_Nm"]),
                str(point["active_intervals"]) if point["reached"] else "not reached",
                short(point["percent"]) if point["reached"] else "",
                short(point["eigenaxis_percent"]),
                short(point["bound_percent"]),
            )
        tables.append(table)
    return Group(*tables)
