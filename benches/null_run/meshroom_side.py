"""Meshroom's core on a chain of nodes that copy a file: makes the graph where it is not there, computes what is to be computed.

    MESHROOM=<a checkout of Meshroom> python meshroom_side.py NODES

The graph is `graph.mg` in the working folder, with its cache beside it. Chunks are computed in this process; usually Meshroom
starts one for each. Needs psutil, requests, markdown and pyseq, and no PySide.
"""

import contextlib
import logging
import os
import pathlib
import shutil
import sys

sys.path.insert(0, os.environ["MESHROOM"])
from meshroom.core import desc, pluginManager
from meshroom.core.graph import Graph, loadGraph
from meshroom.core.plugins import NodePlugin, NodePluginStatus


class Copy(desc.Node):
    inputs = [
        desc.File(name="input", label="Input", description="", value=""),
        desc.IntParam(name="number", label="Number", description="", value=0, range=(0, 1_000_000, 1)),
    ]
    outputs = [desc.File(name="output", label="Output", description="", value="{nodeCacheFolder}/copy")]

    def processChunk(self, chunk):
        shutil.copyfile(chunk.node.input.value, chunk.node.output.value)


plugin = NodePlugin(Copy)
plugin.status = NodePluginStatus.LOADED
pluginManager._nodePlugins["Copy"] = plugin


def make(place, count):
    (place.parent / "take").write_text("0")
    graph = Graph("")
    graph.save(str(place))
    before = None
    for number in range(count):
        node = graph.addNewNode("Copy", number=number)
        if before is None:
            node.input.value = str(place.parent / "take")
        else:
            graph.addEdge(before.output, node.input)
        before = node
    graph.save(str(place))


def main():
    logging.disable(logging.CRITICAL)
    place = pathlib.Path("graph.mg").resolve()
    if not place.exists():
        make(place, int(sys.argv[1]))
    graph = loadGraph(str(place))
    nodes, _ = graph.dfsToProcess()
    for node in nodes:
        node.beginSequence()
    for node in nodes:
        node.preprocess()
        node.process(inCurrentEnv=True)
        node.postprocess()
    for node in nodes:
        node.endSequence()
    return len(nodes)


if __name__ == "__main__":
    with contextlib.redirect_stdout(sys.stderr):
        computed = main()
    print(computed)
