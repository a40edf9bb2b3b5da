/** How tus asks: by fetch, which tells a guard's answer from the service's. XMLHttpRequest follows a redirect unseen. */

import type { HttpRequest, HttpResponse, HttpStack } from "tus-js-client";

import { fromService } from "./refusal";

export const tusByFetch: HttpStack = { createRequest: (method, url) => new Asking(method, url), getName: () => "fetch" };

class Asking implements HttpRequest {
  readonly #headers = new Headers();
  readonly #stopper = new AbortController();

  constructor(
    private readonly method: string,
    private readonly url: string,
  ) {}

  getMethod = () => this.method;
  getURL = () => this.url;
  setHeader = (name: string, value: string) => this.#headers.set(name, value);
  getHeader = (name: string) => this.#headers.get(name) ?? undefined;
  setProgressHandler = () => undefined; // whole pieces are told
  getUnderlyingObject = () => null;

  async abort(): Promise<void> {
    this.#stopper.abort();
  }

  async send(body: BodyInit | null): Promise<HttpResponse> {
    const { signal } = this.#stopper;
    const asked = { method: this.method, headers: this.#headers, body, signal, redirect: "manual" } as const;
    const response = fromService(await fetch(this.url, asked));
    const text = await response.text();
    return {
      getStatus: () => response.status,
      getHeader: (name) => response.headers.get(name) ?? undefined,
      getBody: () => text,
      getUnderlyingObject: () => response,
    };
  }
}
