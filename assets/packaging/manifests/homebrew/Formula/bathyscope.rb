class Bathyscope < Formula
  desc "@SUMMARY@"
  homepage "@RELEASES@"
  version "@VERSION@"
  license any_of: ["MIT", "Apache-2.0"]

  depends_on :linux

  on_arm do
    url "@URL aarch64-linux.tar.gz@"
    sha256 "@SHA256 aarch64-linux.tar.gz@"
  end
  on_intel do
    url "@URL x86_64-linux.tar.gz@"
    sha256 "@SHA256 x86_64-linux.tar.gz@"
  end

  def install
    bin.install "bin/bathyscope"
    share.install Dir["share/*"]
  end

  test do
    assert_match version.to_s, shell_output("#{bin}/bathyscope --version")
  end
end
