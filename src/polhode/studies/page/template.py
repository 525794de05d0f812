"""A study's page: the Markdown template beside its rows, filled with their tables and facts."""

from __future__ import annotations

from collections.abc import Mapping

from polhode.studies.page.tables import PageTable


def filled(template: str, tables: Mapping[str, PageTable], facts: Mapping[str, object]) -> str:
    """The template with its fields filled, as Markdown.

    Under each heading what names tables is left out where none of them has rows.

    >>> filled("# A\\n\\n{n} rows\\n\\n## B\\n\\n{none}\\n", {"none": PageTable((), ())}, {"n": 2})
    '# A\\n\\n2 rows\\n'
    """
    first, *others = template.split("\n#")
    parts = [first, *(f"\n#{part}" for part in others)]
    named = [[tables[name] for name in tables if f"{{{name}}}" in part] for part in parts]
    shown = [part for part, there in zip(parts, named, strict=True) if _has_rows(there)]
    fields = {name: made.markdown for name, made in tables.items()} | dict(facts)
    text = "".join(shown).format_map(fields)
    while "\n\n\n" in text:  # a table without rows beside one that has some
        text = text.replace("\n\n\n", "\n\n")
    return f"{text.strip()}\n"


def _has_rows(tables: list[PageTable]) -> bool:
    return not tables or any(made.rows for made in tables)
