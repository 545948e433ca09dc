#include "mien/onnx/graph.h"

#include <bit>

namespace mien::onnx {
namespace {

static_assert(std::endian::native == std::endian::little, "an ONNX file's raw numbers are little-endian");

std::string raw_bytes(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void set(::onnx::AttributeProto& attribute, std::int64_t value) {
  attribute.set_type(::onnx::AttributeProto::INT);
  attribute.set_i(value);
}
void set(::onnx::AttributeProto& attribute, float value) {
  attribute.set_type(::onnx::AttributeProto::FLOAT);
  attribute.set_f(value);
}
void set(::onnx::AttributeProto& attribute, const std::vector<std::int64_t>& values) {
  attribute.set_type(::onnx::AttributeProto::INTS);
  for (const std::int64_t value : values) attribute.add_ints(value);
}

}  // namespace

Graph::Graph(const std::string& name, const std::string& says) {
  model_.set_ir_version(kIrVersion);
  model_.add_opset_import()->set_version(kOpset);
  model_.set_producer_name("mien");
  model_.set_producer_version(MIEN_VERSION);
  model_.set_doc_string(says);
  graph().set_name(name);
  graph().set_doc_string(says);
}

std::vector<std::byte> Graph::bytes() const {
  std::string text;
  model_.SerializeToString(&text);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void Graph::tell(const std::string& key, const std::string& text) {
  ::onnx::StringStringEntryProto& entry = *model_.add_metadata_props();
  entry.set_key(key);
  entry.set_value(text);
}

std::string Graph::constant(const std::string& name, const std::vector<std::size_t>& shape,
                            std::span<const float> values) {
  ::onnx::TensorProto& tensor = *graph().add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(::onnx::TensorProto::FLOAT);
  for (const std::size_t length : shape) tensor.add_dims(static_cast<std::int64_t>(length));
  tensor.set_raw_data(raw_bytes(std::as_bytes(values)));
  return name;
}

std::string Graph::constant(const std::string& name, const std::vector<std::int64_t>& values) {
  ::onnx::TensorProto& tensor = *graph().add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(::onnx::TensorProto::INT64);
  tensor.add_dims(static_cast<std::int64_t>(values.size()));
  tensor.set_raw_data(raw_bytes(std::as_bytes(std::span(values))));
  return name;
}

::onnx::NodeProto& Graph::node(const char* op, const std::vector<std::string>& inputs) {
  ::onnx::NodeProto& node = *graph().add_node();
  node.set_op_type(op);
  node.set_name(op + ("_" + std::to_string(graph().node_size())));
  for (const std::string& input : inputs) node.add_input(input);
  return node;
}

std::string Graph::add(const char* op, const std::vector<std::string>& inputs,
                       const std::vector<Attribute>& attributes, const std::string& as) {
  ::onnx::NodeProto& made = node(op, inputs);
  for (const Attribute& attribute : attributes) {
    ::onnx::AttributeProto& to = *made.add_attribute();
    to.set_name(attribute.name);
    std::visit([&](const auto& value) { set(to, value); }, attribute.value);
  }
  const std::string result = as.empty() ? "v" + std::to_string(++values_) : as;
  made.add_output(result);
  return result;
}

std::vector<std::string> Graph::split(const std::string& x, std::size_t count, std::int64_t axis) {
  ::onnx::NodeProto& made = node("Split", {x});
  ::onnx::AttributeProto& along = *made.add_attribute();
  along.set_name("axis");
  set(along, axis);
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < count; ++i) {
    parts.push_back("v" + std::to_string(++values_));
    made.add_output(parts.back());
  }
  return parts;
}

void Graph::describe(const Port& port, ::onnx::ValueInfoProto& value) {
  value.set_name(port.name);
  value.set_doc_string(port.says);
  ::onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(port.element == Element::f32 ? ::onnx::TensorProto::FLOAT : ::onnx::TensorProto::INT64);
  for (const Axis& axis : port.shape) {
    auto& to = *type.mutable_shape()->add_dim();
    if (const auto* length = std::get_if<std::size_t>(&axis))
      to.set_dim_value(static_cast<std::int64_t>(*length));
    else
      to.set_dim_param(std::get<const char*>(axis));
  }
}

}  // namespace mien::onnx
