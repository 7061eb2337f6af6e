// SPDX-License-Identifier: Apache-2.0
// Thinning of an image by ITK's BinaryThinningImageFilter, of two dimensions (Debian's ITK has no thinning of volumes).
//   itk_thinning WIDTH HEIGHT IN OUT
// IN, OUT: a byte per pixel, 0 outside. Prints the processor time of the filter alone, on one thread, in seconds.
#include <itkBinaryThinningImageFilter.h>
#include <itkImage.h>
#include <itkMultiThreaderBase.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: itk_thinning WIDTH HEIGHT IN OUT\n";
    return 1;
  }
  using Image = itk::Image<unsigned char, 2>;
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(1);
  auto image = Image::New();
  image->SetRegions(Image::SizeType{{std::strtoul(argv[1], nullptr, 10), std::strtoul(argv[2], nullptr, 10)}});
  image->Allocate();
  const std::size_t pixels = image->GetBufferedRegion().GetNumberOfPixels();
  unsigned char* values = image->GetBufferPointer();
  if (!std::ifstream(argv[3], std::ios::binary).read(reinterpret_cast<char*>(values), pixels)) {
    std::cerr << argv[3] << ": too short\n";
    return 1;
  }
  std::for_each(values, values + pixels, [](unsigned char& v) { v = v ? 1 : 0; });
  auto filter = itk::BinaryThinningImageFilter<Image, Image>::New();
  filter->SetInput(image);
  const std::clock_t start = std::clock();
  filter->Update();
  std::cout << double(std::clock() - start) / CLOCKS_PER_SEC << '\n';
  const bool written(std::ofstream(argv[4], std::ios::binary)
                         .write(reinterpret_cast<const char*>(filter->GetOutput()->GetBufferPointer()), pixels));
  return written ? 0 : 1;
}
