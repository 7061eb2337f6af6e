// SPDX-License-Identifier: Apache-2.0
/// What is wrong with a page, in one sentence for its reader.
export class PageError extends Error {}
