"""The animated page: one self-contained HTML document with the data of an animation."""

from gimcli.output.page.document import page, page_json

__all__ = ["page", "page_json"]
