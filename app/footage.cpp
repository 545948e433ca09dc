#include "app/footage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <system_error>
#include <utility>

#include "app/media_helper.h"
#include "mien/core/files.h"
#include "mien/headset/jpeg_gate.h"

namespace mien::app {
namespace fs = std::filesystem;
namespace {

/// Largest file of one picture.
constexpr std::size_t kMostPictureBytes = std::size_t{64} << 20U;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Whether a name comes before another in a folder: as text, but for numbers in it, which go by their value:
/// "2" before "10". Names that differ by zeros in front alone go as text.
bool comes_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
      continue;
    }
    const auto take_number = [](const std::string& text, std::size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const std::size_t begin = at;
      while (at < text.size() && is_digit(text[at])) ++at;
      return std::string_view(text).substr(begin, at - begin);
    };
    const std::string_view one = take_number(a, i), other = take_number(b, j);
    if (one.size() != other.size()) return one.size() < other.size();
    if (one != other) return one < other;
  }
  if (i < a.size() || j < b.size()) return i == a.size();
  return a < b;
}

bool is_picture(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".jpg" || ending == ".jpeg" || ending == ".pgm" || ending == ".ppm";
}

class Folder final : public Footage {
 public:
  explicit Folder(std::vector<fs::path> files) : files_(std::move(files)) {}

  Result<std::optional<Shot>> next() override {
    if (next_ == files_.size()) return std::nullopt;
    const fs::path& path = files_[next_++];
    MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, read_file(path, kMostPictureBytes));
    Shot shot;
    shot.where = path.string();
    MIEN_TRY_ASSIGN(shot.picture, headset::parse_picture(bytes, shot.where));
    if (headset::check_jpeg(bytes)) shot.jpeg = std::move(bytes);
    return shot;
  }
  [[nodiscard]] std::size_t about() const override { return files_.size(); }

 private:
  std::vector<fs::path> files_;
  std::size_t next_ = 0;
};

class Film final : public Footage {
 public:
  Film(FilmReader reader, std::string where) : reader_(std::move(reader)), where_(std::move(where)) {}

  Result<std::optional<Shot>> next() override {
    Shot shot;
    shot.where = fmt::format("{}, picture {}", where_, ++number_);
    shot.picture.width = reader_.width();
    shot.picture.height = reader_.height();
    shot.picture.pixels.resize(static_cast<std::size_t>(reader_.width()) *
                               static_cast<std::size_t>(reader_.height()));
    MIEN_TRY_ASSIGN(const bool more, reader_.next(shot.picture.pixels));
    if (!more) return std::nullopt;
    if (number_ > kMostPictures)
      return fail(ErrorCode::out_of_range, fmt::format("over {} pictures", kMostPictures), where_,
                  "import it in parts");
    return shot;
  }
  [[nodiscard]] std::size_t about() const override { return reader_.about(); }

 private:
  FilmReader reader_;
  std::string where_;
  std::size_t number_ = 0;
};

Result<std::vector<fs::path>> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    std::error_code ignored;
    if (!is_picture(entry->path()) || !entry->is_regular_file(ignored)) continue;
    if (files.size() == Footage::kMostPictures)
      return fail(ErrorCode::out_of_range, fmt::format("over {} pictures", Footage::kMostPictures),
                  folder.string(), "import them in parts");
    files.push_back(entry->path());
  }
  if (code) return fail(ErrorCode::io, code.message(), folder.string());
  if (files.empty())
    return fail(ErrorCode::not_found, "no picture is in this folder", folder.string(),
                "pictures are .jpg, .jpeg, .pgm or .ppm files");
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return comes_before(a.filename().string(), b.filename().string());
  });
  return files;
}

}  // namespace

Result<std::unique_ptr<Footage>> Footage::open(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    MIEN_TRY_ASSIGN(std::vector<fs::path> files, pictures_in(path));
    return std::make_unique<Folder>(std::move(files));
  }
  if (!fs::exists(path, ignored))
    return fail(ErrorCode::not_found, "there is no such folder or film", path.string());
  MIEN_TRY_ASSIGN(FilmReader reader,
                  FilmReader::start(path, headset::kMaxPictureWidth, headset::kMaxPictureHeight));
  return std::make_unique<Film>(std::move(reader), path.string());
}

}  // namespace mien::app
