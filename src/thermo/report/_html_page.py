"""One page in HTML that is a file by itself."""

from __future__ import annotations

import html


def html_page(title: str, style: str, body: str, *, head: str = "", script: str = "") -> str:
    """A page that loads nothing: all that it needs stands in it.

    Arguments: `title`, plain text; `style`, its CSS; `body` and `head`, HTML; `script`, JavaScript
    that runs before the body is there.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"{head}"
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{html.escape(title)}</title><style>{style}</style>"
        f"<script>{script}</script></head>\n<body>\n{body}\n</body></html>\n"
    )
