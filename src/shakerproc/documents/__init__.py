"""Strict YAML with the place of every node, checked against a pydantic schema.

Every message opens with ``file:line:column:``, says where, what was expected, what was found.
"""

from shakerproc.documents.document import (
    Document,
    FromList,
    Section,
    kind_of_file,
    misplaced,
    read_document,
)
from shakerproc.documents.tree import Key
