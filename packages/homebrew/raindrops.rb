# Not run: written on Debian, by Homebrew's Formula Cookbook.
class Raindrops < Formula
  desc "Raindrops rendered as raindrops on Vulkan, with the error known"
  homepage "URL"
  url "URL/archive/v1.0.0.tar.gz"
  sha256 "0000000000000000000000000000000000000000000000000000000000000000"
  license any_of: ["MIT", "Apache-2.0"]

  depends_on "rust" => :build
  depends_on "shaderc" => :build
  depends_on "vulkan-loader"

  on_macos do
    depends_on "molten-vk"
  end

  on_linux do
    depends_on "mesa"
  end

  def install
    # .cargo/config.toml would look for the library where scripts/setup.sh puts it.
    ENV["SHADERC_LIB_DIR"] = Formula["shaderc"].opt_lib.to_s
    system "cargo", "install", *std_cargo_args
    generate_completions_from_executable(bin/"raindrops", "completions")
    system bin/"raindrops", "--quiet", "man", "-o", "man"
    man1.install Dir["man/*"]
    pkgshare.install "assets/scenes", "assets/porch", "assets/scene.schema.json", "assets/sky.exr", "assets/low-sun.exr"
  end

  test do
    assert_match "preset", shell_output("#{bin}/raindrops plan --size 64x64")
  end
end
