// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/geotiff.h"

#include <geotiff/geotiff.h>
#include <geotiff/geotiffio.h>
#include <geotiff/xtiffio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "geotiff_picture.h"
#include "kestrel_slam/map/atomic_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

using Tiff = std::unique_ptr<TIFF, decltype(&XTIFFClose)>;
using GeoKeys = std::unique_ptr<GTIF, decltype(&GTIFFree)>;

void writePicture(TIFF* tiff, const GeotiffPicture& picture) {
  constexpr int kChannels = 3, kBits = 8, kByDifference = 2;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, picture.width());
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, picture.height());
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kChannels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kBits);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, kByDifference);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
  for (int y = 0; y < picture.height(); ++y) {
    std::vector<std::uint8_t> row = picture.row(y);
    if (TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0) != 1) {
      throw std::runtime_error("the disk may be full");
    }
  }
}

void writeGeoKeys(TIFF* tiff, const GeotiffPicture& picture) {
  const double pixel = picture.metersPerPixel();
  std::array<double, 3> scale = {pixel, pixel, 0.0};
  std::array<double, 6> corner = {0.0, 0.0, 0.0, -picture.corner().y(), picture.corner().x(), 0.0};
  TIFFSetField(tiff, TIFFTAG_GEOPIXELSCALE, static_cast<int>(scale.size()), scale.data());
  TIFFSetField(tiff, TIFFTAG_GEOTIEPOINTS, static_cast<int>(corner.size()), corner.data());
  const GeoKeys keys(GTIFNew(tiff), &GTIFFree);
  if (!keys) throw std::runtime_error("libgeotiff failed");
  GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
  GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(keys.get(), GTCitationGeoKey, TYPE_ASCII, 0, "map frame, m: north is x, east is -y");
  GTIFKeySet(keys.get(), ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  GTIFWriteKeys(keys.get());
}

/// The six lines of a world file; the last two are the center of the upper left pixel.
std::string worldFile(const GeotiffPicture& picture) {
  const double pixel = picture.metersPerPixel();
  std::ostringstream text;
  text << std::fixed << std::setprecision(10);
  for (const double value : {pixel, 0.0, 0.0, -pixel, -picture.corner().y() + pixel / 2.0,
                             picture.corner().x() - pixel / 2.0}) {
    text << value << "\n";
  }
  return text.str();
}

void writeTiff(const std::string& path, const GeotiffPicture& picture) {
  errno = 0;
  Tiff tiff(XTIFFOpen(path.c_str(), "w"), &XTIFFClose);
  if (!tiff) throw std::runtime_error(std::strerror(errno != 0 ? errno : EIO));
  writeGeoKeys(tiff.get(), picture);
  writePicture(tiff.get(), picture);
}

}  // namespace

void writeGeotiff(const std::string& name, const GeotiffContent& content) {
  TIFFSetErrorHandler(nullptr);  // errors are thrown, not printed
  const std::string path = name + ".tif", temporary = path + "." + std::to_string(::getpid());
  try {
    const GeotiffPicture picture(content);
    writeTiff(temporary, picture);
    fs::rename(temporary, path);
    writeFileAtomically(name + ".tfw", worldFile(picture));
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw std::runtime_error("cannot write " + path + ": " + error.what());
  }
}

}  // namespace kestrel
