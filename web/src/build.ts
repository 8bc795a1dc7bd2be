declare const BUILD_VERSION: string;

/** Checksum of the sources that this page was built from. */
export const VERSION = BUILD_VERSION;
