#!/usr/bin/env python3
"""Prints what LiteRT, the networks' own interpreter, makes of the drawn face of tests/core/network/drawn_face.h: the
numbers in installed_networks_test.cpp. Run by hand where they are to be made anew, with the PyPI packages
ai-edge-litert==2.3.0 and numpy, on the folder mediapipe/modules/ of the wheel that packaging/networks fetches:

    tests/core/network/litert_outputs.py MODULES
"""
import struct
import sys

import flatbuffers
import numpy as np
from ai_edge_litert import schema_py_generated as schema
from ai_edge_litert.interpreter import Interpreter

# As in drawn_face.h: half axes and centre in hundredths of the side, colour; a later one covers the earlier ones.
ELLIPSES = [
    ((48, 40), (50, 118), (40, 60, 110)),
    ((13, 20), (50, 78), (196, 150, 126)),
    ((27, 36), (50, 42), (60, 44, 36)),
    ((23, 31), (50, 47), (214, 168, 142)),
    ((6, 1), (40, 37), (70, 50, 40)),
    ((6, 1), (60, 37), (70, 50, 40)),
    ((5, 2), (40, 42), (240, 238, 236)),
    ((5, 2), (60, 42), (240, 238, 236)),
    ((2, 2), (40, 42), (50, 40, 36)),
    ((2, 2), (60, 42), (50, 40, 36)),
    ((3, 7), (50, 50), (200, 152, 128)),
    ((4, 1), (50, 57), (150, 104, 88)),
    ((8, 2), (50, 65), (176, 84, 84)),
]


def drawn_face(side):
    at = (2 * np.arange(side) + 1) * 50  # of a pixel's centre, times the side
    picture = np.empty((side, side, 3), np.int64)
    picture[:] = (150, 170, 180)
    for (a, b), (x, y), colour in ELLIPSES:
        u, v = at[None, :] - x * side, at[:, None] - y * side
        picture[(u * b) ** 2 + (v * a) ** 2 <= (a * b * side) ** 2] = colour
    return picture - (abs(at - 50 * side) // (2 * side))[None, :, None]  # darker to the sides


def with_known_operators(data):
    """LiteRT lacks MediaPipe's transposed convolution with a bias; its own takes the output's shape and that bias."""
    model = schema.ModelT.InitFromPackedBuf(data, 0)
    graph = model.subgraphs[0]
    for operator in graph.operators:
        code = model.operatorCodes[operator.opcodeIndex]
        if code.customCode != b"Convolution2DTransposeBias":
            continue
        padding, columns, rows = struct.unpack("<3i", bytes(operator.customOptions)[:12])
        shape = schema.TensorT()
        shape.name, shape.shape, shape.type = b"output_shape", [4], schema.TensorType.INT32
        values = schema.BufferT()
        values.data = list(struct.pack("<4i", *graph.tensors[operator.outputs[0]].shape))
        model.buffers.append(values)
        shape.buffer = len(model.buffers) - 1
        graph.tensors.append(shape)
        picture, weights, bias = operator.inputs
        operator.inputs = [len(graph.tensors) - 1, weights, picture, bias]
        code.builtinCode = code.deprecatedBuiltinCode = schema.BuiltinOperator.TRANSPOSE_CONV
        code.customCode, code.version = None, 3
        options = schema.TransposeConvOptionsT()
        options.padding, options.strideW, options.strideH = padding, columns, rows
        operator.customOptions = None
        operator.builtinOptionsType, operator.builtinOptions = schema.BuiltinOptions.TransposeConvOptions, options
    builder = flatbuffers.Builder(len(data))
    builder.Finish(model.Pack(builder), b"TFL3")
    return bytes(builder.Output())


def outputs(path, side, scale, mean):
    """Each output by its name, pictures as (1, channels, rows, columns), flat."""
    with open(path, "rb") as file:
        interpreter = Interpreter(model_content=with_known_operators(file.read()), num_threads=1)
    interpreter.allocate_tensors()
    picture = ((drawn_face(side) - mean) * scale).astype(np.float32)[None]
    interpreter.set_tensor(interpreter.get_input_details()[0]["index"], picture)
    interpreter.invoke()
    for output in interpreter.get_output_details():
        values = interpreter.get_tensor(output["index"])
        yield output["name"], (values.transpose(0, 3, 1, 2) if values.ndim == 4 else values).ravel()


def main():
    modules = sys.argv[1]
    for name, path, side, scale, mean in [
            ("person", "selfie_segmentation/selfie_segmentation", 256, 1 / 255, 0),
            ("face468", "face_landmark/face_landmark", 192, 1 / 255, 0),
            ("iris", "iris_landmark/iris_landmark", 64, 1 / 255, 0),
            ("face_detector", "face_detection/face_detection_short_range", 128, 1 / 127.5, 127.5)]:
        for output, values in outputs(f"{modules}/{path}.tflite", side, scale, mean):
            # Six spread over all, and the six nearest to the middle of their range: most of a mask is 0 or 1.
            spread = range(0, len(values), -(-len(values) // 6))
            middle = np.argsort(abs(values - (values.min() + values.max()) / 2), kind="stable")[:6]
            chosen = sorted({int(i) for i in [*spread, *middle]})
            print(f"{{{name}, \"{output}\", {len(values)}, {values.mean(dtype=np.float64):.7g},",
                  "{" + ", ".join(map(str, chosen)) + "}, {" + ", ".join(f"{values[i]:.7g}" for i in chosen) + "}},")


if __name__ == "__main__":
    main()
