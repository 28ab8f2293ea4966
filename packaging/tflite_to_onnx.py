#!/usr/bin/env python3
"""Turns a small TensorFlow Lite network into an ONNX file that OpenCV 4.6 reads; the numbers stay what they were.

    packaging/tflite_to_onnx.py IN.tflite OUT.onnx

Only the operators of the networks that packaging/networks converts are known; another is named, and nothing is
written. The same input gives the same bytes with any version of the three packages that this needs: tflite, onnx,
numpy.

TensorFlow Lite keeps pictures as (1, rows, columns, channels), ONNX as (1, channels, rows, columns). A tensor of four
dimensions is therefore transposed in everything that is written here, and all others are as they were; where a picture
becomes a list, its old order is restored first. What OpenCV 4.6 refuses, though ONNX allows it, is written otherwise:
weights of half precision (in single), Clip with bounds as inputs (not at all), Resize without the inputs it does not
need (with them).
"""
import struct
import sys

import numpy as np
import onnx
import tflite
from onnx import helper, numpy_helper

OPSET, IR_VERSION = 12, 7
NUMPY_TYPES = {
    tflite.TensorType.FLOAT32: np.float32,
    tflite.TensorType.FLOAT16: np.float16,
    tflite.TensorType.INT32: np.int32,
}
OPERATOR_NAMES = {number: name for name, number in vars(tflite.BuiltinOperator).items() if isinstance(number, int)}


class NotConvertible(Exception):
    """Something in the network that is not known here; its text names it."""


def require(condition, what):
    if not condition:
        raise NotConvertible(what)


def options_of(operator, kind):
    """The operator's options, of the class that belongs to it."""
    options, stored = kind(), operator.BuiltinOptions()
    options.Init(stored.Bytes, stored.Pos)
    return options


def same_padding(size, kernel, stride, dilation):
    """Rows and columns added (top, left) and (bottom, right) so that the output has size / stride, rounded up."""
    before, after = [], []
    for n, k, s, d in zip(size, kernel, stride, dilation):
        total = max((-(-n // s) - 1) * s + (k - 1) * d + 1 - n, 0)
        before.append(total // 2)
        after.append(total - total // 2)
    return before, after


class Converter:
    """One network. Tensors are known by their number in the file."""

    def __init__(self, data):
        self.model = tflite.Model.GetRootAsModel(data, 0)
        require(self.model.SubgraphsLength() == 1, "more than one graph")
        self.graph = self.model.Subgraphs(0)
        self.inputs = [int(i) for i in self.graph.InputsAsNumpy()]
        self.outputs = [int(i) for i in self.graph.OutputsAsNumpy()]
        self.constants = {}  # tensor -> values in TensorFlow Lite's order
        self.nodes, self.initialisers = [], []
        self.count = 0  # of names given
        self.names = {i: self.graph.Tensors(i).Name().decode() for i in self.inputs + self.outputs}
        for i in range(self.graph.TensorsLength()):
            tensor = self.graph.Tensors(i)
            stored = self.model.Buffers(tensor.Buffer())
            if stored.DataLength():
                require(tensor.Type() in NUMPY_TYPES, f"constants of type {tensor.Type()}")
                values = np.frombuffer(stored.DataAsNumpy().tobytes(), NUMPY_TYPES[tensor.Type()])
                self.constants[i] = values.reshape(self.shape(i))

    # -- What is read

    def shape(self, tensor):
        found = self.graph.Tensors(tensor)
        return found.ShapeAsNumpy().tolist() if found.ShapeLength() else []

    def size(self, tensor):
        """Rows and columns of a picture."""
        return self.shape(tensor)[1:3]

    def weights(self, tensor):
        return self.constants[tensor].astype(np.float32)

    # -- What is written

    def name(self, tensor):
        return self.names.setdefault(tensor, f"t{tensor}")

    def new_name(self, stem):
        self.count += 1
        return f"{stem}_{self.count}"

    def constant(self, values, stem="c"):
        name = self.new_name(stem)
        self.initialisers.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def node(self, kind, inputs, outputs, **attributes):
        self.nodes.append(helper.make_node(kind, inputs, outputs, name=self.new_name(kind), **attributes))

    def padding(self, mode, size, kernel, stride, dilation=(1, 1)):
        """The attributes of a window's padding."""
        if mode == tflite.Padding.VALID:
            return {}
        before, after = same_padding(size, kernel, stride, dilation)
        if not any(before + after):
            return {}
        # The odd row and column at the end: the one asymmetry that both formats have a word for.
        return {"pads": before + after} if before == after else {"auto_pad": "SAME_UPPER"}

    def no_fused_activation(self, options):
        require(options.FusedActivationFunction() == tflite.ActivationFunctionType.NONE, "a fused activation")

    # -- Operators, each with the numbers of its inputs and of its output

    def dequantise(self, _, inputs, output):
        self.constants[output] = self.weights(inputs[0])

    def convolution(self, operator, inputs, output):
        options = options_of(operator, tflite.Conv2DOptions)
        self.write_convolution(options, inputs, output, self.weights(inputs[1]).transpose(0, 3, 1, 2), 1)  # from OHWI

    def depthwise_convolution(self, operator, inputs, output):
        options = options_of(operator, tflite.DepthwiseConv2DOptions)
        channels = self.shape(inputs[0])[3]
        self.write_convolution(options, inputs, output, self.weights(inputs[1]).transpose(3, 0, 1, 2), channels)  # from 1HWO

    def write_convolution(self, options, inputs, output, weights, groups):
        self.no_fused_activation(options)
        kernel = list(weights.shape[2:])
        stride = [options.StrideH(), options.StrideW()]
        dilation = [options.DilationHFactor(), options.DilationWFactor()]
        padding = self.padding(options.Padding(), self.size(inputs[0]), kernel, stride, dilation)
        given = [self.name(inputs[0]), self.constant(weights, "w"), self.constant(self.weights(inputs[2]), "b")]
        self.node("Conv", given, [self.name(output)], kernel_shape=kernel, strides=stride, dilations=dilation,
                  group=groups, **padding)

    def transposed_convolution(self, operator, inputs, output):
        """MediaPipe's own operator: padding, strides of columns and rows as three integers; input, weights, bias."""
        _, columns, rows = struct.unpack("<3i", bytes(operator.CustomOptionsAsNumpy())[:12])
        weights = self.weights(inputs[1]).transpose(3, 0, 1, 2)  # from OHWI to IOHW
        enlarged = [n * s for n, s in zip(self.size(inputs[0]), (rows, columns))]
        require(list(weights.shape[2:]) == [rows, columns] and enlarged == self.size(output),
                "a transposed convolution whose windows overlap")
        given = [self.name(inputs[0]), self.constant(weights, "w"), self.constant(self.weights(inputs[2]), "b")]
        self.node("ConvTranspose", given, [self.name(output)], kernel_shape=[rows, columns], strides=[rows, columns])

    def add(self, operator, inputs, output):
        self.no_fused_activation(options_of(operator, tflite.AddOptions))
        self.write_product_or_sum("Add", inputs, output)

    def multiply(self, operator, inputs, output):
        self.no_fused_activation(options_of(operator, tflite.MulOptions))
        self.write_product_or_sum("Mul", inputs, output)

    def write_product_or_sum(self, kind, inputs, output):
        # OpenCV repeats only the second factor over the first's picture.
        larger_first = sorted(inputs, key=lambda tensor: -np.prod(self.shape(tensor)))
        require(not any(tensor in self.constants for tensor in inputs), f"{kind} of a constant")
        self.node(kind, [self.name(tensor) for tensor in larger_first], [self.name(output)])

    def rectify(self, _, inputs, output):
        self.node("Relu", [self.name(inputs[0])], [self.name(output)])

    def logistic(self, _, inputs, output):
        self.node("Sigmoid", [self.name(inputs[0])], [self.name(output)])

    def hard_swish(self, _, inputs, output):
        """x * min(max(x / 6 + 1 / 2, 0), 1)"""
        gate = self.new_name("hs")
        self.node("HardSigmoid", [self.name(inputs[0])], [gate], alpha=1 / 6, beta=0.5)
        self.node("Mul", [self.name(inputs[0]), gate], [self.name(output)])

    def parametric_rectify(self, _, inputs, output):
        slopes = self.weights(inputs[1])
        require(slopes.size == slopes.shape[-1], "slopes that differ within a channel")
        self.node("PRelu", [self.name(inputs[0]), self.constant(slopes.reshape(-1, 1, 1), "slope")], [self.name(output)])

    def average_pool(self, operator, inputs, output):
        options = options_of(operator, tflite.Pool2DOptions)
        self.no_fused_activation(options)
        require([options.FilterHeight(), options.FilterWidth()] == self.size(inputs[0]), "averages of a picture's parts")
        self.node("GlobalAveragePool", [self.name(inputs[0])], [self.name(output)])

    def max_pool(self, operator, inputs, output):
        options = options_of(operator, tflite.Pool2DOptions)
        self.no_fused_activation(options)
        kernel, stride = [options.FilterHeight(), options.FilterWidth()], [options.StrideH(), options.StrideW()]
        padding = self.padding(options.Padding(), self.size(inputs[0]), kernel, stride)
        self.node("MaxPool", [self.name(inputs[0])], [self.name(output)], kernel_shape=kernel, strides=stride, **padding)

    def resize_bilinear(self, operator, inputs, output):
        options = options_of(operator, tflite.ResizeBilinearOptions)
        require(options.HalfPixelCenters() and not options.AlignCorners(), "Resize by other than pixel centres")
        (rows, columns), (new_rows, new_columns) = self.size(inputs[0]), self.size(output)
        no_region = self.constant(np.zeros(0, np.float32), "roi")
        scales = self.constant(np.array([1, 1, new_rows / rows, new_columns / columns], np.float32))
        self.node("Resize", [self.name(inputs[0]), no_region, scales], [self.name(output)], mode="linear",
                  coordinate_transformation_mode="half_pixel")

    def pad(self, _, inputs, output):
        amounts = self.constants[inputs[1]].reshape(-1, 2)
        require(len(amounts) == 4, "padding of what is no picture")
        amounts = amounts[[0, 3, 1, 2]]
        begins_and_ends = np.concatenate([amounts[:, 0], amounts[:, 1]]).astype(np.int64)
        given = [self.name(inputs[0]), self.constant(begins_and_ends), self.constant(np.float32(0))]
        self.node("Pad", given, [self.name(output)], mode="constant")

    def reshape(self, _, inputs, output):
        name, shape = self.name(inputs[0]), self.shape(inputs[0])
        require(len(self.shape(output)) != 4, "a list made into a picture")
        if len(shape) == 4 and shape[1] * shape[2] > 1 and shape[3] > 1:
            restored = self.new_name("nhwc")
            self.node("Transpose", [name], [restored], perm=[0, 2, 3, 1])
            name = restored
        self.node("Reshape", [name, self.constant(np.array(self.shape(output), np.int64))], [self.name(output)])

    def concatenate(self, operator, inputs, output):
        options = options_of(operator, tflite.ConcatenationOptions)
        self.no_fused_activation(options)
        require(len(self.shape(output)) != 4, "pictures laid side by side")
        self.node("Concat", [self.name(tensor) for tensor in inputs], [self.name(output)], axis=options.Axis())

    OPERATORS = {
        "DEQUANTIZE": dequantise,
        "CONV_2D": convolution,
        "DEPTHWISE_CONV_2D": depthwise_convolution,
        "Convolution2DTransposeBias": transposed_convolution,
        "ADD": add,
        "MUL": multiply,
        "RELU": rectify,
        "LOGISTIC": logistic,
        "HARD_SWISH": hard_swish,
        "PRELU": parametric_rectify,
        "AVERAGE_POOL_2D": average_pool,
        "MAX_POOL_2D": max_pool,
        "RESIZE_BILINEAR": resize_bilinear,
        "PAD": pad,
        "RESHAPE": reshape,
        "CONCATENATION": concatenate,
    }

    # -- The whole

    def described(self, tensor):
        """A tensor of the outside: its name, type and shape."""
        shape = self.shape(tensor)
        if len(shape) == 4:
            shape = [shape[0], shape[3], shape[1], shape[2]]
        return helper.make_tensor_value_info(self.name(tensor), onnx.TensorProto.FLOAT, shape)

    def convert(self):
        for i in range(self.graph.OperatorsLength()):
            operator = self.graph.Operators(i)
            code = self.model.OperatorCodes(operator.OpcodeIndex())
            kind = OPERATOR_NAMES[max(code.BuiltinCode(), code.DeprecatedBuiltinCode())]
            if kind == "CUSTOM":
                kind = code.CustomCode().decode()
            require(kind in self.OPERATORS, f"the operator {kind}")
            inputs = [int(tensor) for tensor in operator.InputsAsNumpy()]
            self.OPERATORS[kind](self, operator, inputs, int(operator.Outputs(0)))
        graph = helper.make_graph(self.nodes, "g", [self.described(i) for i in self.inputs],
                                  [self.described(i) for i in self.outputs], self.initialisers)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)],
                                  producer_name="tflite_to_onnx", ir_version=IR_VERSION)
        onnx.checker.check_model(model, full_check=True)
        return model


def main():
    if len(sys.argv) != 3 or sys.argv[1] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if sys.argv[1:] in (["-h"], ["--help"]) else 2
    source, target = sys.argv[1:]
    try:
        with open(source, "rb") as file:
            model = Converter(file.read()).convert()
    except NotConvertible as unknown:
        print(f"{source} cannot be converted: {unknown} is not known here.", file=sys.stderr)
        return 1
    onnx.save(model, target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
