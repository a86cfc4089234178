"""Writes a density grid as an OpenVDB file (file version 224: half floats, ZIP), with Python's standard library alone.

The tree is that of openvdb::FloatGrid: a root, nodes of 32^3 and of 16^3, leaves of 8^3 voxels. Values of 0 are
inactive and not written; the background is 0.
"""

import struct
import zlib

LEAF, LOWER, UPPER = 8, 128, 4096  # voxels along a side of a leaf, of a node of leaves, of a node of those
ZIP, ACTIVE_MASK = 1, 2  # compression
ONLY_ACTIVE_VALUES = b"\0"  # what a node's values are written as


def text(string):
    return struct.pack("<I", len(string)) + string.encode()


def metadata(entries):
    """Entries are (name, type, value in bytes)."""
    packed = struct.pack("<I", len(entries))
    for name, kind, value in entries:
        packed += text(name) + text(kind) + struct.pack("<I", len(value)) + value
    return packed


def mask(indices, count):
    """A bit each, by 64-bit words."""
    bits = bytearray(count // 8)
    for index in indices:
        bits[index // 8] |= 1 << index % 8
    return bytes(bits)


def zipped(data):
    """What does not become smaller is stored as it is, with its size negative."""
    packed = zlib.compress(data, 9)
    if len(packed) < len(data):
        return struct.pack("<q", len(packed)) + packed
    return struct.pack("<q", -len(data)) + data


def child_index(origin, size, child_size):
    """Of a child within its node: x slowest."""
    side = size // child_size
    x, y, z = (o % size // child_size for o in origin)
    return (x * side + y) * side + z


def grouped(origins, size):
    """The origins of nodes of `size` voxels, each with its children's in the order of the file."""
    nodes = {}
    for origin in origins:
        nodes.setdefault(tuple(o // size * size for o in origin), []).append(origin)
    return nodes


def write_vdb(path, values, voxel_size, origin):
    """`values` maps (i, j, k) to a density above 0; voxel (0, 0, 0) lies at `origin`, m."""
    leaves = {}
    for (i, j, k), value in values.items():
        corner = tuple(c // LEAF * LEAF for c in (i, j, k))
        leaves.setdefault(corner, {})[child_index((i, j, k), LEAF, 1)] = value
    lowers = grouped(leaves, LOWER)
    uppers = grouped(lowers, UPPER)

    def inner(origin, children, size, child_size):
        """Child mask, value mask and (no) values of an inner node without tiles; its children by their places."""
        places = sorted((child_index(child, size, child_size), child) for child in children)
        count = (size // child_size) ** 3
        head = mask([place for place, child in places], count) + bytes(count // 8)
        return head + ONLY_ACTIVE_VALUES, [child for place, child in places]

    def leaf_mask(leaf):
        return mask(leaves[leaf], LEAF**3)

    topology = struct.pack("<IfII", 1, 0, 0, len(uppers))  # buffers, background, tiles, children
    buffers = b""
    for upper in sorted(uppers):
        head, below = inner(upper, uppers[upper], UPPER, LOWER)
        topology += struct.pack("<3i", *upper) + head
        for lower in below:
            head, below_that = inner(lower, lowers[lower], LOWER, LEAF)
            topology += head
            for leaf in below_that:
                topology += leaf_mask(leaf)
                ordered = [leaves[leaf][place] for place in sorted(leaves[leaf])]
                buffers += leaf_mask(leaf) + ONLY_ACTIVE_VALUES
                buffers += zipped(struct.pack(f"<{len(ordered)}e", *ordered))

    matrix = [voxel_size, 0, 0, 0, 0, voxel_size, 0, 0, 0, 0, voxel_size, 0, *origin, 1]
    head = struct.pack("<I", ZIP | ACTIVE_MASK)
    head += metadata([("class", "string", b"fog volume"), ("is_saved_as_half_float", "bool", b"\1"), ("name", "string", b"density")])
    head += text("AffineMap") + struct.pack("<16d", *matrix) + topology

    file_head = struct.pack("<qIII?", 0x56444220, 224, 9, 1, True)  # magic, file and library version, offsets
    file_head += b"00000000-0000-4000-8000-000000000000" + metadata([]) + struct.pack("<I", 1)
    file_head += text("density") + text("Tree_float_5_4_3_HalfFloat") + text("")
    start = len(file_head) + 24
    offsets = struct.pack("<3q", start, start + len(head), start + len(head) + len(buffers))
    with open(path, "wb") as file:
        file.write(file_head + offsets + head + buffers)
