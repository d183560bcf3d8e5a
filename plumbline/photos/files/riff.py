"""WebP files: a note in a chunk of its own, where EXIF cannot take it.

Readers skip chunks that they do not know. Source: WebP Container Specification, "Unknown Chunks".
"""

from __future__ import annotations

import struct


def with_remark(data: bytes, remark: str) -> bytes:
    """A WebP file with a remark behind everything else; the same file if there is none."""
    if not remark:
        return data
    text = remark.encode()
    chunk = b"NOTE" + struct.pack("<I", len(text)) + text + b"\0" * (len(text) % 2)
    (size,) = struct.unpack_from("<I", data, 4)
    return data[:4] + struct.pack("<I", size + len(chunk)) + data[8:] + chunk
