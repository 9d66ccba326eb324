#include "scheduler/policies/learned/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/sha256.h"

namespace muster::scheduler::learned {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kFormat = 1;
constexpr std::string_view kMagic = "MUSTERNN";
constexpr std::uint32_t kMostNumbers = 1U << 28;
static_assert(std::endian::native == std::endian::little, "model.bin is little-endian");

void Put(std::string* bytes, std::uint32_t number) {
  bytes->append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::string BytesOf(const Tensors& tensors) {
  std::string bytes(kMagic);
  Put(&bytes, static_cast<std::uint32_t>(tensors.size()));
  for (const auto& [name, tensor] : tensors) {
    Put(&bytes, static_cast<std::uint32_t>(name.size()));
    bytes += name;
    Put(&bytes, static_cast<std::uint32_t>(tensor.shape.size()));
    for (const int n : tensor.shape) Put(&bytes, static_cast<std::uint32_t>(n));
    bytes.append(reinterpret_cast<const char*>(tensor.values.data()),
                 tensor.values.size() * sizeof(float));
  }
  return bytes;
}

class Reader {
 public:
  Reader(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  Tensors Read() {
    if (Text(kMagic.size()) != kMagic) Fail("another kind of file");
    Tensors tensors;
    const std::uint32_t n = Number();
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::string name = Text(Number());
      Tensor tensor;
      const std::uint32_t dims = Number();
      std::uint64_t numbers = 1;
      for (std::uint32_t d = 0; d < dims; ++d) {
        tensor.shape.push_back(static_cast<int>(Number() & (kMostNumbers - 1)));
        numbers *= static_cast<std::uint64_t>(tensor.shape.back());
        if (numbers > kMostNumbers) Fail("too large a layer");
      }
      const std::string raw = Text(numbers * sizeof(float));
      tensor.values.resize(numbers);
      std::memcpy(tensor.values.data(), raw.data(), raw.size());
      tensors[name] = std::move(tensor);
    }
    if (at_ != bytes_.size()) Fail("more than its layers");
    return tensors;
  }

 private:
  [[noreturn]] void Fail(std::string_view found) const {
    throw InputError(file_, "weights", found, "the weights of a model");
  }
  std::string Text(std::uint64_t n) {
    if (n > bytes_.size() - at_) Fail("a file cut short");
    std::string text = bytes_.substr(at_, n);
    at_ += n;
    return text;
  }
  std::uint32_t Number() {
    std::uint32_t number = 0;
    std::memcpy(&number, Text(sizeof number).data(), sizeof number);
    return number;
  }

  const std::string& bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
};

void WriteWhole(const std::string& file, const std::string& bytes) {
  const std::string next = file + ".next";
  std::ofstream out(next, std::ios::binary);
  out << bytes;
  out.close();
  std::error_code error;
  if (out) fs::rename(next, file, error);
  if (!out || error) throw SystemError(fmt::format("{}: cannot be written", file));
}

std::string ReadWhole(const std::string& file, const std::string& folder) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw InputError("policy", "learned", folder,
                     "the folder of a model of muster train (docs/guide/learned.md)");
  }
  return {std::istreambuf_iterator<char>(in), {}};
}

Json ToJson(const Shape& shape) {
  return {{"columns", shape.columns},          {"rows", shape.rows},
          {"uavs", shape.agents.uavs},         {"workers", shape.agents.workers},
          {"vehicles", shape.agents.vehicles}, {"interval_us", shape.interval_us},
          {"limit_us", shape.limit_us}};
}

}  // namespace

void WriteModel(const Model& model, const std::string& folder) {
  const std::string bytes = BytesOf(model.tensors);
  const Json json = {{"format", kFormat},
                     {"method", model.method},
                     {"shape", ToJson(model.shape)},
                     {"features", kFeatureVersion},
                     {"options", kOptions},
                     {"preset", model.preset},
                     {"seed", model.seed},
                     {"episodes", model.episodes},
                     {"train_s", model.train_s},
                     {"held_out_completion", model.held_out},
                     {"trained_by", model.trained_by},
                     {"weights_sha256", Sha256(bytes)}};
  WriteWhole(folder + "/model.bin", bytes);
  WriteWhole(folder + "/model.json", json.dump(2) + "\n");
}

Model ReadModel(const std::string& folder) {
  const std::string file = folder + "/model.json";
  const std::string text = ReadWhole(file, folder);
  Model model;
  std::string hash;
  try {
    const Json json = Json::parse(text);
    const int format = json.at("format"), features = json.at("features"),
              options = json.at("options");
    if (format != kFormat || features != kFeatureVersion || options != kOptions) {
      throw InputError(
          file, "format, features, options", fmt::format("{}, {}, {}", format, features, options),
          fmt::format("{}, {}, {}: train it again", kFormat, kFeatureVersion, kOptions));
    }
    model.method = json.at("method");
    if (std::find(kMethodNames.begin(), kMethodNames.end(), model.method) == kMethodNames.end()) {
      throw InputError(file, "method", model.method, "a method of muster train");
    }
    const Json& shape = json.at("shape");
    model.shape.columns = shape.at("columns");
    model.shape.rows = shape.at("rows");
    model.shape.agents = {shape.at("uavs"), shape.at("workers"), shape.at("vehicles")};
    model.shape.interval_us = shape.at("interval_us");
    model.shape.limit_us = shape.at("limit_us");
    model.preset = json.at("preset");
    model.seed = json.at("seed");
    model.episodes = json.at("episodes");
    model.train_s = json.at("train_s");
    model.held_out = json.at("held_out_completion");
    model.trained_by = json.at("trained_by");
    hash = json.at("weights_sha256");
  } catch (const Json::exception&) {
    throw InputError(file, "model", "no such description", "what muster train writes");
  }
  const std::string weights = folder + "/model.bin";
  const std::string bytes = ReadWhole(weights, folder);
  if (Sha256(bytes) != hash) {
    throw InputError(weights, "weights", "others", "those that model.json was written for");
  }
  model.tensors = Reader(bytes, weights).Read();
  return model;
}

}  // namespace muster::scheduler::learned
