"""XMP packets: the promise of further pictures and videos taken out."""

from __future__ import annotations

_PROMISES = {
    "http://ns.adobe.com/hdr-gain-map/1.0/": "",
    "http://ns.apple.com/HDRGainMap/1.0/": "",
    "http://ns.google.com/photos/1.0/container/": "",
    "http://ns.google.com/photos/1.0/camera/": "Motion MicroVideo",
}
"""Namespaces whose properties tell of what hangs behind the picture; with words: those alone."""


def promises(packet: bytes) -> bool:
    """Whether XMP tells of a gain map or another picture behind the one it belongs to."""
    return any(space.encode() in packet for space in _PROMISES)


def tells_of_gain_map(packet: bytes) -> bool:
    """Whether XMP tells of a gain map."""
    return any(word in packet for word in (b"hdr-gain-map", b"HDRGainMap", b"GainMap"))


def without_promises(packet: bytes) -> bytes:
    """The packet without properties about gain maps, further pictures and videos.

    Raises:
        ValueError: it cannot be read as XML.
    """
    from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

    start, end = packet.find(b"<x:xmpmeta"), packet.rfind(b"</x:xmpmeta>")
    if start < 0 or end < 0:
        start, end = packet.find(b"<rdf:RDF"), packet.rfind(b"</rdf:RDF>")
    if start < 0 or end < 0:
        raise ValueError("the XMP packet has no beginning or no end")
    end = packet.index(b">", end) + 1
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    try:
        root = etree.fromstring(packet[start:end], parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(str(error)) from None
    for element in list(root.iter("*")):
        for name in list(element.attrib):
            if _is_promise(str(name)):
                del element.attrib[name]
        parent = element.getparent()
        if parent is not None and _is_promise(str(element.tag)):
            parent.remove(element)
    etree.cleanup_namespaces(root)
    return packet[:start] + etree.tostring(root) + packet[end:]


def _is_promise(name: str) -> bool:
    space, _, word = name.removeprefix("{").partition("}")
    if space not in _PROMISES:
        return False
    starts = _PROMISES[space].split()
    return not starts or any(word.startswith(start) for start in starts)
